import json,sys,subprocess
sys.path.insert(0,'/work/clones/kernel/proofs')
from checker.statements import check, refusal, THEOREMS
def convert(old):
    subject={k:old[k] for k in ('states','rhs','at')}
    def ev(entries):
        return {"squares":[entries]}
    proofs={}; faces={}
    mus={}
    for name,f in old['faces'].items(): faces[name]=f['cell']
    facegroups={}
    for name,e in old['proofs'].items():
        pre='rate ' if name.startswith('rate ') else ''
        base=name[len(pre):]
        if base.startswith('face '):
            _,fname,_,cell,_,num=base.split()
            facegroups.setdefault((pre,fname),[]).append((cell,num,e))
        else: proofs[name]=ev(e)
    for (pre,fname),l in facegroups.items():
        f=old['faces'][fname]
        zero=[j for j,c in enumerate(fname) if c=='0']
        mu=[f['mu'].get(str(j),[]) for j in zero]
        # order as in dictionary = order of inequalities
        proofs[f"{pre}face {fname}"]={"squares":[e for _,_,e in l],"mu":mu}
    empty=[]
    n=len(old['surfaces'])
    for entry in old['empty']:
        signs=['.']*n; 
        from fractions import Fraction
        d={}
        for num,s,w in entry:
            signs[num]=s; d[num]=Fraction(w)
        last=max(k for k in d)
        assert d[last]>0 or True
        # choose: need weight of last>0
        if d[last]==0: raise SystemExit('zero weight')
        empty.append({"signs":"".join(signs),"proof":{"mixture":[{f"s{k}":str(v/d[last]) for k,v in d.items() if k!=last and v}]}})
    ly={"within":old['radius'],"function":old['lyapunov'],"surfaces":old['surfaces'],"empty":empty,"proofs":proofs}
    if old['lyapunov'] is None:
        ent={"theorem":"departure","hypotheses":{"direction":old['direction'],"within":old['radius'],"surfaces":old['surfaces'],"empty":empty}}
        claims=[{"equilibrium":False}]
    elif old['verdict']=='unstable':
        ent={"theorem":"instability","hypotheses":{"direction":old['direction'],"lyapunov":ly}}
        claims=[{"stability":"unstable"}]
    else:
        ent={"theorem":"lyapunov","hypotheses":{"verdict":old['verdict'],"everywhere":old['everywhere'],"level":old['level'],"rate":old['rate'],"lyapunov":ly}}
        claims=[{"stability":old['verdict']}]
        if old['everywhere']: claims.append({"attracts":"everywhere"})
        if old['level']: claims.append({"attracts":{"function":old['lyapunov'],"within":old['radius'],"below":old['level']}})
        if old['rate']: claims.append({"rate":{"function":old['lyapunov'],"within":old['radius'],**old['rate']}})
    return {"version":"nonsmooth-certificate/2","statement":{"subject":subject,"claims":claims},"evidence":[ent]}
if __name__=='__main__':
    import time
    for p in sys.argv[1:]:
        old=json.load(open(p)); new=convert(old); t=time.time()
        print(p,old['verdict'],repr(refusal(new,len(json.dumps(new)))),round(time.time()-t,2))
        json.dump(new,open(p.replace('.json','.2.json'),'w'))
